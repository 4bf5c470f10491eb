__all__=[]
def order_of(t): return 16
