"""The memory of one cutting edge: a Gaussian-process model of its errors by contact angle, over parts."""
