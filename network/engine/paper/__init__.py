"""The closed form of the heat-quantity method, its tables and fits beside ours."""
