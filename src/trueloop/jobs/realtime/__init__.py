"""What `trueloop realtime` does with files."""
