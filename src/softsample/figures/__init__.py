"""Figures of a study: functions that take arrays and frames and return a Matplotlib figure."""
