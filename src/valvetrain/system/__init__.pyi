from valvetrain.system.problem import Problem as Problem
