"""The views beside the portrait, one file each: which inputs, which computation, which figure."""
