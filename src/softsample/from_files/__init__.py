"""What the files of a study hold, as what the diagnosis and the report work on."""
