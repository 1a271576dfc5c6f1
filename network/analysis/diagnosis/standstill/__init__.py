"""The search for stops that recordings do not tell: every stretch of every run scored, the best confirmed by fits."""
