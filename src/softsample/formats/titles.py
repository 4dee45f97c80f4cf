"""What titles of columns and units may be called: the one table that readers of records use.

Synonyms of machines and languages go here, and `tests/unit/test_titles.py` reads each of them.
"""

import math
import re
from collections.abc import Iterable

COLUMNS = {
    "time": "time_s",
    "displacement": "displacement_mm",
    "strain": "strain",
    "stretch": "stretch",
    "angle": "angle_rad",
    "force": "force_N",
    "stress": "stress_Pa",
    "force_normal": "force_normal_N",
    "torque": "torque_Nmm",
}
"""The quantities of a record, and the columns that they are read into."""

NAMES = {
    "time": {
        *("time", "zeit", "prüfzeit", "testzeit", "versuchszeit", "laufzeit", "temps", "tiempo"),
        *("tempo", "elapsed", "runtime", "timestamp", "uhrzeit", "datetime", "date/time"),
        *("时间", "時間", "время"),
    },
    "displacement": {
        *("displacement", "disp", "displ", "extension", "compression", "travel", "stroke"),
        *("position", "pos", "crosshead", "actuator", "separation", "elongation", "deflection"),
        *("deformation", "gap", "weg", "verfahrweg", "kolbenweg", "prüfweg", "traverse"),
        *("standardweg", "werkzeugabstand", "verformung", "distance"),
        *("traversenweg", "traversenposition", "verlängerung", "verschiebung", "auslenkung"),
        *("scherweg", "hub", "déplacement", "allongement", "course", "desplazamiento"),
        *("spostamento", "depth", "indentation", "penetration", "eindringtiefe", "eindringweg"),
        *("profondeur", "profundidad", "位移", "変位", "перемещение", "удлинение"),
    },
    "force": {
        *("force", "load", "kraft", "standardkraft", "prüfkraft", "zugkraft", "druckkraft"),
        *("scherkraft", "last", "loadcell", "charge", "effort", "fuerza", "carga"),
        *("forza", "力", "载荷", "荷重", "試験力", "сила", "нагрузка", "усилие"),
    },
    "strain": {
        *("strain", "dehnung", "stauchung", "scherung", "déformation", "deformación"),
        *("应变", "ひずみ", "деформация"),
    },
    "stretch": {"stretch", "lambda", "λ"},
    "angle": {"angle", "rotation", "twist", "winkel", "drehwinkel", "verdrehung", "ángulo"},
    "torque": {"torque", "drehmoment", "moment", "couple", "par"},
    "stress": {
        *("stress", "spannung", "druckspannung", "zugspannung", "schubspannung", "contrainte"),
        *("tensión", "esfuerzo", "应力", "応力", "напряжение"),
    },
}
"""What a title may call a quantity, in lower case; a title may hold several of one set."""

BESIDE = {
    *("axial", "tensile", "compressive", "crosshead", "elapsed", "total", "test", "corrected"),
    *("cell", "channel", "engineering", "nominal", "shear", "grip", "actuator", "machine"),
    *("platen", "plate", "indenter", "applied", "measured", "actual", "digital", "primary", "ch"),
    "running",
}
"""Words of a title that do not change what it names."""

TRUE = {
    *("true", "cauchy", "log", "ln", "logarithmic", "hencky", "natural"),
    *("wahre", "wahrer", "logarithmische", "umformgrad", "vraie", "verdadera"),
}
"""Words of a title that say that stress or strain is that of the deformed sample."""

SHEARED = re.compile("shear|schub|scher|cisaill|cizall|cortante|taglio", re.IGNORECASE)
"""Part of a title that says that a quantity acts along the platen."""

NUMBERED = re.compile(r"(ch)?\d+", re.ASCII)
"""Words that tell specimens or channels apart, and do not change what a title names either."""

COMPRESSIVE = re.compile(
    "(?<!de)(?<!un)compress|druckkraft|druckspannung|stauchung"
    "|depth|indentation|penetration|eindring|profondeur|profundidad",
    re.IGNORECASE,
)
"""Part of a title that says that compression is positive."""


def _all(*spelled: tuple[Iterable[str], float]) -> dict[str, float]:
    """Sizes of units by all of their spellings."""
    return {name: size for names, size in spelled for name in names}


_RATIOS = (
    (("1", "-", "mm/mm", "MM/MM", "m/m", "in/in"), 1.0),
    (("%", "percent", "Prozent"), 1e-2),
)

UNITS = {
    "time": _all(
        (("s", "S", "sec", "Sec", "SEC", "secs", "second", "seconds", "Sekunden"), 1.0),
        (("с", "сек", "秒"), 1.0),
        (("ms", "msec", "millisecond", "milliseconds"), 1e-3),
        (("us", "µs", "μs"), 1e-6),
        (("min", "Min", "minute", "minutes", "Minuten"), 60.0),
        (("d", "day", "days"), 86400.0),
        (("h", "hr", "hour", "hours"), 3600.0),
    ),
    "displacement": _all(
        (("mm", "MM", "millimeter", "millimetre", "millimeters", "millimetres", "мм"), 1.0),
        (("cm", "centimeter", "centimetre"), 10.0),
        (("um", "µm", "μm", "micron", "microns", "micrometer", "micrometre"), 1e-3),
        (("m", "meter", "metre"), 1e3),
        (("nm",), 1e-6),
        (("in", "inch", "inches"), 25.4),
        (("mil", "mils", "thou"), 25.4e-3),
    ),
    "force": _all(
        (("N", "Newton", "newton", "Newtons", "newtons", "Н"), 1.0),
        (("mN", "мН"), 1e-3),
        (("gf", "gF", "g", "gram", "grams", "p", "pond"), 9.80665e-3),
        (("kN", "кН"), 1e3),
        (("daN",), 10.0),
        (("cN",), 1e-2),
        (("uN", "µN", "μN"), 1e-6),
        (("kgf", "kgF", "kg", "kp"), 9.80665),
        (("lbf", "lbF", "lb", "lbs"), 4.4482216152605),
        (("ozf", "ozF"), 0.27801385095378125),
        (("dyn", "dyne", "dynes"), 1e-5),
    ),
    "strain": _all(*_RATIOS, (("µε", "με", "microstrain"), 1e-6)),
    "stretch": _all(*_RATIOS),
    "angle": _all(
        (("rad", "radian", "radians"), 1.0),
        (("deg", "Deg", "°", "degree", "degrees", "Grad"), math.pi / 180.0),
        (("mrad",), 1e-3),
        (("rev", "turns"), 2.0 * math.pi),
    ),
    "stress": _all(
        (("Pa", "Па", "N/m2", "N/m²", "N/m^2"), 1.0),
        (("kPa", "KPa", "Kpa", "кПа", "kN/m2", "kN/m²", "kN/m^2"), 1e3),
        (("MPa", "Mpa", "МПа", "N/mm2", "N/mm²", "N/mm^2"), 1e6),
        (("psi",), 6894.757293168361),
    ),
    "torque": _all(
        (("Nmm", "N mm", "N·mm", "N*mm", "N.mm", "N-mm", "mNm", "mN m", "mN·m", "mN.m"), 1.0),
        (("Nm", "N m", "N·m", "N*m", "N.m", "N-m"), 1e3),
        (("uNm", "µNm", "μNm", "uN m", "µN m", "µN·m"), 1e-3),
    ),
}
UNITS["force_normal"] = UNITS["force"]
"""Units by quantity, upper and lower case as they are written, and their size in ours.

Those that are likelier to be mistaken for ours come first, as `check` proposes them in this order.
"""
