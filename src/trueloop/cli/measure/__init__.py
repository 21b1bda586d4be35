"""`trueloop measure …`"""
