"""What the readers of inspection files share: text, numbers, times, names, and checks of what is said twice."""
