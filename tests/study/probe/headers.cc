// Empty source for the precompiled headers of all probes, because CMake requires a source.
