"""What a user asks for as a whole: a run, a collapse, a limit load, a refinement, a study."""
