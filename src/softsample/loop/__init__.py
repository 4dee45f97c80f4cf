"""From the residual of a calibrated model to the effect that it lacks."""
