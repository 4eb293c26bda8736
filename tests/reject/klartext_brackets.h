BEGIN PGM REFUSED MM
L X+0 Y+0 Z+0 R0 FMAX
Q1 = ((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((1
END PGM REFUSED MM
