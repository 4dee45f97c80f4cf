"""Tables of a study, beside the paper's values, and the numbers of its captions."""
