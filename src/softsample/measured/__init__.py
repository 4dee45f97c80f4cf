"""Records that others measured: readers, models of their ideal shapes, and the loop on them."""
