"""The DSNN in the integer arithmetic of the Colias's processor: a specification in NumPy, and the same in C.

``params`` has the parameters, ``fixed`` the whole numbers computed from them, and ``codes`` the 8-bit formats.
``numpy_form`` is the specification, and ``header`` writes the C header for the robot. ``model`` is the registered
model, and ``error`` compares it with the float network.
"""
