"""
What does coil clash do to the force on the seat?
=================================================

The beehive spring at 8000 rpm of the engine by three models. In the chain of masses and in the
finite-element rod, coils that meet push
each other. In the modal model they pass through each other, and none of the spikes shows.
"""

import valvetrain as vt

models = ["multi-mass", "finite-element", "modal-uniform"]
coarse = {"spring.options.finite-element.elements_per_coil": 8}
study = vt.simulate(
    vt.load_case("gu2021-beehive-blind", coarse), "8000 rpm", models=models, workers=1
)

for model in models:
    run = study.solution(model)
    clashes = sum(event.kind == "clash" for event in run.events)
    print(f"{model:14s} peak {run.quantities['peak_spring_force']:.0f} N, {clashes} clashes")

# %%
# The force on the seat over the reported turn of the cam. Eight elements a coil make a quick
# picture; ``valvetrain refine`` tells what
# a finer mesh changes.

figure = study.plot()
