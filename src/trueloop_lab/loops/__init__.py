"""The loops on virtual machines, whose errors are known."""
