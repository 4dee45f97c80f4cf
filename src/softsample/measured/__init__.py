"""Public measured sets as study folders: catalogue, one reader a set, and the writer."""
