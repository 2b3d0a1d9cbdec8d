// Owns the precompiled headers of the tests: parsing them anew takes a third of the time to build.
