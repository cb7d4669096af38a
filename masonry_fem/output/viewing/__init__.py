"""Viewing: a results folder step by step, in a window, in the browser, as a movie or as a glTF model."""
