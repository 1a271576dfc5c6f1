"""What is told: findings with their numbers, sets and confidence, and what every answer has to hold."""
