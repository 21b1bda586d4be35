"""LinuxCNC, service and pages together: parts made unattended on a virtual lathe that wears and warms."""
