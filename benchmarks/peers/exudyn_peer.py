"""Jobs T and C in Exudyn: rigid pieces of wire joined by six-component bushings, implicit
generalised-alpha.

Its own geometrically exact beam takes straight references only. Piece i is centred on vertex i; the
bushing between two
vertices carries the stiffness of the wire between them and is free of stress on the helix.
"""

from __future__ import annotations

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np
from common import (
    BEND,
    CONTACT_STIFFNESS,
    DAMPING,
    DURATION,
    MASS_PER_LENGTH,
    PER_TURN,
    PRECOMPRESSION,
    SPIN_INERTIA,
    STRETCH,
    TURNS,
    WIRE,
    answer,
    displacement,
    options,
    start,
    wire,
)
from exudyn.utilities import CreateSymbolicUserFunction


def build(job: str, per_coil: int, damping: str, damped: str = "all"):
    """Assembled system and the number of the first bushing's sensor."""
    alpha, beta = DAMPING[damping]
    count = int(TURNS * per_coil)
    turn = np.linspace(0.0, TURNS, count + 1)
    position, frame, speed = wire(turn, job)
    middle, middle_frame, middle_speed = wire((turn[1:] + turn[:-1]) / 2, job)
    length, arc = middle_speed / per_coil, speed / per_coil
    container = exu.SystemContainer()
    system = container.AddSystem()
    system.variables["static"] = True
    ground = system.AddObject(item.ObjectGround(referencePosition=position[0].tolist()))
    bodies = [ground]
    for i in range(1, count + 1):
        share = 0.5 if i == count else 1.0
        mass, spin = share * MASS_PER_LENGTH * arc[i], share * SPIN_INERTIA * arc[i]
        # Body axes are the space axes at the start, so that rotation vectors begin at zero.
        tensor = frame[i] @ np.diag(spin) @ frame[i].T
        node = system.AddNode(
            item.NodeRigidBodyRotVecLG(
                referenceCoordinates=[*position[i], 0.0, 0.0, 0.0], initialVelocities=[0.0] * 6
            )
        )
        inertia = [
            tensor[0, 0],
            tensor[1, 1],
            tensor[2, 2],
            tensor[1, 2],
            tensor[0, 2],
            tensor[0, 1],
        ]
        bodies.append(
            system.AddObject(
                item.ObjectRigidBody(physicsMass=mass, physicsInertia=inertia, nodeNumber=node)
            )
        )
        if alpha:
            damp = np.zeros((6, 6))
            damp[:3, :3] = alpha * mass * np.eye(3)
            damp[3:, 3:] = alpha * tensor
            fixed = system.AddMarker(
                item.MarkerBodyRigid(
                    bodyNumber=ground, localPosition=(position[i] - position[0]).tolist()
                )
            )
            moving = system.AddMarker(item.MarkerBodyRigid(bodyNumber=bodies[i]))
            system.AddObject(
                item.ObjectConnectorRigidBodySpringDamper(
                    markerNumbers=[fixed, moving],
                    stiffness=np.zeros((6, 6)),
                    damping=damp,
                )
            )
    bushings = []
    for i in range(count):
        markers = [
            system.AddMarker(
                item.MarkerBodyRigid(
                    bodyNumber=bodies[k], localPosition=(middle[i] - position[k]).tolist()
                )
            )
            for k in (i, i + 1)
        ]
        stiffness = np.diag(np.concatenate([STRETCH, BEND]) / length[i])
        mask = np.diag([0.0 if damped == "bending" else 1.0] * 3 + [1.0] * 3)
        bushings.append(
            system.AddObject(
                item.ObjectConnectorRigidBodySpringDamper(
                    markerNumbers=markers,
                    stiffness=stiffness,
                    damping=beta * stiffness @ mask,
                    rotationMarker0=middle_frame[i],
                    rotationMarker1=middle_frame[i],
                )
            )
        )
    hold_top(system, ground, count)
    touching = contacts(system, bodies, arc, per_coil) if job == "C" else []
    sensors = [
        system.AddSensor(
            item.SensorObject(objectNumber=number, outputVariableType=kind, storeInternal=True)
        )
        for number, kind in (
            (bushings[0], exu.OutputVariableType.ForceLocal),
            *((number, exu.OutputVariableType.Force) for number in touching[:1]),
        )
    ]
    system.Assemble()
    return container, system, sensors, middle_frame[0]


def hold_top(system, ground: int, count: int) -> None:
    """Clamp the last piece to the retainer: five coordinates fixed, the height prescribed."""
    base = system.AddMarker(
        item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0)
    )

    def height_of(sys, time_now, number, offset):
        return -PRECOMPRESSION * time_now if sys.variables["static"] else -displacement(time_now)

    for coordinate in range(6):
        marker = system.AddMarker(
            item.MarkerNodeCoordinate(nodeNumber=count - 1, coordinate=coordinate)
        )
        extra = {"offsetUserFunction": height_of} if coordinate == 2 else {}
        system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[base, marker], **extra))


def contacts(system, bodies, arc, per_coil: int) -> list[int]:
    """Line contact between neighbouring coils: one point pair per piece, a one-sided spring of the
    wire's line stiffness.

    The pair stands at equal angle, not at the closest point. Returns the springs; the first one
    rests on the clamped tip.
    """
    symbolic = exu.symbolic

    def one_sided(sys, time_now, number, change, rate, stiffness, damping, preload):
        return stiffness * 0.5 * (change - symbolic.abs(change))

    springs, last = [], len(bodies) - 1
    for i in range(per_coil, len(bodies)):
        length = arc[i] * (0.5 if i in (per_coil, last) else 1.0)
        markers = [
            system.AddMarker(item.MarkerBodyPosition(bodyNumber=bodies[k]))
            for k in (i - per_coil, i)
        ]
        spring = system.AddObject(
            item.ObjectConnectorSpringDamper(
                markerNumbers=markers,
                referenceLength=WIRE,
                stiffness=CONTACT_STIFFNESS * length,
                damping=0.0,
            )
        )
        law = CreateSymbolicUserFunction(system, one_sided, "springForceUserFunction", spring)
        system.SetObjectParameter(spring, "springForceUserFunction", law)
        springs.append(spring)
    return springs


def run() -> None:
    """One job with the options of the command line."""
    wanted = options()
    started = start()
    _container, system, sensors, frame = build(
        wanted["job"], wanted["per_coil"], wanted["damping"], wanted.get("damped", "all")
    )
    settings = exu.SimulationSettings()
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    settings.solutionSettings.writeSolutionToFile = False
    settings.parallel.numberOfThreads = 1
    settings.staticSolver.numberOfLoadSteps = 4
    settings.staticSolver.newton.relativeTolerance = 1e-6
    settings.staticSolver.verboseMode = 0
    settings.timeIntegration.verboseMode = 0
    if not system.SolveStatic(settings, updateInitialValues=True):
        raise SystemExit("no static solution")
    system.variables["static"] = False
    settings.timeIntegration.endTime = DURATION
    settings.timeIntegration.numberOfSteps = round(DURATION / wanted["step"])
    settings.solutionSettings.sensorsWritePeriod = DURATION / (2 * PER_TURN)
    settings.timeIntegration.generalizedAlpha.spectralRadius = wanted.get("radius", 0.8)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
    settings.timeIntegration.newton.useModifiedNewton = True
    # A contact that keeps changing state within a step must not end the run.
    settings.timeIntegration.discontinuous.ignoreMaxIterations = True
    settings.timeIntegration.discontinuous.maxIterations = 3
    settings.timeIntegration.newton.relativeTolerance = wanted.get("tolerance", 1e-6)
    if not system.SolveDynamic(settings):
        raise SystemExit("the time integration did not end")
    rows = system.GetSensorStoredData(sensors[0])
    force = -(rows[:, 1:4] @ frame.T)[:, 2]
    for sensor in sensors[1:]:
        force = force + np.linalg.norm(system.GetSensorStoredData(sensor)[:, 1:4], axis=1)
    times = np.linspace(0.0, DURATION, 2 * PER_TURN + 1)
    trace = np.interp(times, rows[:, 0], force)
    answer(started, trace, steps=int(settings.timeIntegration.numberOfSteps))


if __name__ == "__main__":
    run()
