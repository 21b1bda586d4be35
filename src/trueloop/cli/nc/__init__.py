"""`trueloop nc …`"""
