"""The servo cylinder's piston as an FMU of its own (PythonFMU): load, friction and the controller of its valve.

    pip install pythonfmu
    python -m pythonfmu build -f examples/fmu/piston.py     # writes Piston.fmu

Forces of both gas columns in; positions and speeds of both strokes and openings of the valve out. Within a step the forces are those of
its start. SI units.
"""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Piston(Fmi2Slave):
    description = "Piston of a servo cylinder with load, friction and valve controller"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.mass, self.friction, self.stroke, self.target, self.conductance = 2.0, 60.0, 0.2, 0.13, 2e-9
        self.capForce = self.rodForce = 0.0
        self.capPosition = self.rodPosition = 0.1
        self.capVelocity = self.rodVelocity = 0.0
        self.capSupply = self.capExhaust = self.rodSupply = self.rodExhaust = 0.0
        for name in ("mass", "friction", "stroke", "target", "conductance"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        for name in ("capForce", "rodForce"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for side in ("cap", "rod"):
            for name in ("Position", "Velocity", "Supply", "Exhaust"):
                self.register_variable(Real(side + name, causality=Fmi2Causality.output))

    def exit_initialization_mode(self):
        self.capPosition = self.rodPosition = 0.5 * self.stroke

    def do_step(self, current_time, step_size):
        opening = max(-1.0, min(1.0, 12.0 * (self.target - self.capPosition) - 0.9 * self.capVelocity))
        # The chambers move by the speed of the step's start, and so does the piston: they agree on where it is.
        self.capPosition += step_size * self.capVelocity
        self.rodPosition = self.stroke - self.capPosition
        # Friction at the end of the step, the gas's forces at its start.
        push = (self.capForce - self.rodForce) * step_size / self.mass
        self.capVelocity = (self.capVelocity + push) / (1.0 + self.friction * step_size / self.mass)
        self.rodVelocity = -self.capVelocity
        self.capSupply = self.rodExhaust = self.conductance * max(0.0, opening)
        self.capExhaust = self.rodSupply = self.conductance * max(0.0, -opening)
        return True
