from valvetrain.views.answer import Answer as Answer
from valvetrain.views.json import study_json as study_json
