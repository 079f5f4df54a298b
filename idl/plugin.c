// The back end that idlc loads (idlc -l PATH). It generates one C++ header for each IDL file.
#include <idlc/generator.h>

#include "idl/write_header.h"

static const char* wanted_namespace = "";

static idlc_option_t space = {IDLC_STRING,   {.string = &wanted_namespace},
                              's',           NULL,
                              "<namespace>", "Put everything into this C++ namespace."};

__attribute__((visibility("default"))) const idlc_option_t** generator_options(void);
__attribute__((visibility("default"))) int generate(const idl_pstate_t* state,
                                                    const idlc_generator_config_t* config);

const idlc_option_t** generator_options(void) {
  static const idlc_option_t* options[] = {&space, NULL};
  return options;
}

int generate(const idl_pstate_t* state, const idlc_generator_config_t* config) {
  tree_begin(config);
  return write_header(state, wanted_namespace, config->output_dir) ? IDL_RETCODE_OK
                                                                   : IDL_RETCODE_SEMANTIC_ERROR;
}
