// a link to what is folded opens it; what is folded on the screen is printed
function unfold() {
  const target = document.getElementById(location.hash.slice(1));
  if (target instanceof HTMLDetailsElement) target.open = true;
  target?.scrollIntoView();
}
if (location.hash) unfold();
window.addEventListener("hashchange", unfold);
window.addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(part => { part.open = true; }));

// a click on the head of a column sorts its table, a second one the other way
function key(row, place) {
  const text = row.cells[place].textContent, number = parseFloat(text.replace("\u2212", "-"));
  return Number.isNaN(number) ? text : number;
}

function compared(one, other) {
  if (typeof one !== typeof other) return typeof one === "number" ? -1 : 1;
  return one < other ? -1 : Number(one > other);
}

for (const head of document.querySelectorAll("main thead th")) {
  head.addEventListener("click", () => {
    const body = head.closest("table").tBodies[0], place = head.cellIndex;
    const rows = [...body.rows].sort((one, other) => compared(key(one, place), key(other, place)));
    const back = head.getAttribute("aria-sort") === "ascending";
    head.closest("tr").querySelectorAll("th").forEach(cell => cell.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", back ? "descending" : "ascending");
    body.append(...(back ? rows.reverse() : rows));
  });
}
