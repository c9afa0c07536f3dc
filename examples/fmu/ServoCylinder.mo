within ;
model ServoCylinder "A piston between two chambers, each an imported FMU, with a proportional valve"
  // Import Chamber.fmu first (OpenModelica: File > Import FMU); the tool makes a block of it, here named Chamber_cs_FMU.
  // Set its name in the next line if your tool chose another.
  replaceable block ChamberFMU = Chamber_cs_FMU "The imported FMU";
  parameter Modelica.Units.SI.Length stroke = 0.2;
  parameter Modelica.Units.SI.Mass mass = 2.0 "Piston, rod and load";
  parameter Real friction(unit = "N.s/m") = 60;
  parameter Modelica.Units.SI.AbsolutePressure supply = 7e5;
  parameter Modelica.Units.SI.AbsolutePressure ambient = 1.013e5;
  parameter Modelica.Units.SI.Temperature ambientTemperature = 293;
  parameter Real conductance(unit = "m3/(s.Pa)") = 2e-9 "Valve fully open";
  parameter Modelica.Units.SI.Length target = 0.13;
  ChamberFMU left(initialPressure = 4e5, initialTemperature = ambientTemperature);
  ChamberFMU right(initialPressure = 4e5, initialTemperature = ambientTemperature);
  Modelica.Units.SI.Length x(start = stroke/2, fixed = true);
  Modelica.Units.SI.Velocity v(start = 0, fixed = true);
  Real opening = max(-1, min(1, 12*(target - x) - 0.9*v));
protected
  function orifice "ISO 6358 with b = 0.3, upstream gas at ambient temperature"
    input Real opening;
    input Real upstream;
    input Real downstream;
    input Real conductance;
    output Real massFlow;
  protected
    Real ratio = downstream/upstream;
  algorithm
    massFlow := if ratio >= 1 then 0 else opening*conductance*upstream*1.185*(
      if ratio <= 0.3 then 1 else sqrt(max(0, 1 - ((ratio - 0.3)/0.7)^2)));
  end orifice;
equation
  der(x) = v;
  mass*der(v) = left.force - right.force - friction*v;
  left.position = x;
  left.velocity = v;
  right.position = stroke - x;
  right.velocity = -v;
  left.massFlowIn = orifice(max(opening, 0), supply, left.pressure, conductance);
  left.massFlowOut = orifice(max(-opening, 0), left.pressure, ambient, conductance);
  right.massFlowIn = orifice(max(-opening, 0), supply, right.pressure, conductance);
  right.massFlowOut = orifice(max(opening, 0), right.pressure, ambient, conductance);
  left.temperatureIn = ambientTemperature;
  right.temperatureIn = ambientTemperature;
  left.ambientTemperature = ambientTemperature;
  right.ambientTemperature = ambientTemperature;
  left.ambientPressure = ambient;
  right.ambientPressure = ambient;
  annotation (experiment(StopTime = 2, Interval = 1e-3));
end ServoCylinder;
