"""`trueloop realtime`: the machine's errors corrected in the servo thread of LinuxCNC."""
