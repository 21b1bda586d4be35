"""What is wrong with a program before it cuts."""
