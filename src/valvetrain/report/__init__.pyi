from valvetrain.report.json import study_json as study_json
from valvetrain.report.study import study_page as study_page
