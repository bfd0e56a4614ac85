from valvetrain.views.answer import Answer as Answer
