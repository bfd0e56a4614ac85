from valvetrain.rig.channels import RigAnswers as RigAnswers
from valvetrain.rig.cycles import rig_cycles as rig_cycles
from valvetrain.rig.result import RigResult as RigResult
