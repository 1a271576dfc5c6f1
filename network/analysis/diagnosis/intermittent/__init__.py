"""The search for what comes and goes in a reading: change points, and the fault behind them."""
