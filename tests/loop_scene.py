"""Scene file of an adhesion loop that runs in a second."""

# Approach and retraction with adhesion; elastic by intent.
LOOP = """
[substrate]
model = "atoms"
spacing = 2.5
contact_modulus = 100.0
shape = [18, 18]
hardness = inf
[sphere]
unit = "a0"
radius = 20.0
[interaction]
kind = "adhesive"
work_of_adhesion = 1.0
[path]
kind = "loop"
deepest = "0.2 nm"
step = 0.5
tolerance = 0.01
cantilever = 60.0
[solver]
accuracy = "fast"
"""
