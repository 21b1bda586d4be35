"""The loops on a virtual machine, whose errors are known."""
