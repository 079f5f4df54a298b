// Exports the function that Cyclone DDS 11 looks for in the library of a PSMX instance of the type
// "example".
__attribute__((visibility("default"))) int example_create_psmx(void) { return 0; }
