#include "pipeline/version.h"

namespace slim {

std::string program_version() { return SLIM_VERSION " (" SLIM_COMMIT ")"; }

}  // namespace slim
