"""The files of `trueloop realtime`."""
