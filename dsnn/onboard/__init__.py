"""The DSNN in the integer arithmetic of Colias's own processor: one form in NumPy, which specifies it, and one in C.

``params`` has what a person sets, ``fixed`` the whole numbers made of it, ``codes`` the 8-bit formats, ``numpy_form``
the specification, ``header`` the C header for the robot, ``model`` the model of the registry, and ``error`` the
comparison with the float network.
"""
