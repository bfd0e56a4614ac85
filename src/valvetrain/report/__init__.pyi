from valvetrain.report.json import study_json as study_json
