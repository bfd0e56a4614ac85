"""
Which tolerance matters
=======================

Sobol indices share the variance of a number among what is varied. The peak force of this spring takes
its spread from the wire, not from the mean diameter.
"""

import valvetrain as vt

space = vt.Space(
    {"spring.wire_diameter": vt.Normal("4 mm", "0.01 mm"), "spring.mean_diameter": vt.Normal("24 mm", "0.02 mm")}
)  # fmt: skip
outputs = vt.Outputs(["peak_spring_force"], engine_speeds="4000 rpm", spring_models="modal-uniform")
experiment = vt.Experiment("job-t", space, outputs)
for one in experiment.sample("saltelli", {"count": 128}, workers=2).sensitivities:
    print(one.output, dict(zip(one.names, one.total.round(2), strict=True)))

# %%
# The same experiment drawn at random: the force over both sizes.

experiment.sample(options={"count": 32}, workers=2)
