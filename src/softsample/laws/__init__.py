"""Which elastic law a group of samples follows: response, fit and choice of any law."""
