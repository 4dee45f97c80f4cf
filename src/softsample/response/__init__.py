"""Unit-modulus response of any shape, test and law, how it changes, and the force it predicts."""
