"""Fields of displacement over the work space, and the frame they are given in."""
