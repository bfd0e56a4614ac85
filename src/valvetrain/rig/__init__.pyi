from valvetrain.rig.cycles import rig_cycles as rig_cycles
from valvetrain.rig.request import RigAnswers as RigAnswers
from valvetrain.rig.result import RigResult as RigResult
