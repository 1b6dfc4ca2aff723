// Nothing but the headers that all probes share, precompiled: CMake wants a source to hang them on.
