#include "formats/image_io.h"
#include "slim/base/error.h"

#include <dlfcn.h>
#include <filesystem>

namespace slim {

/// Loads OpenImageIO only now, in a module of its own beside the program: few pictures have an
/// image of light, and loading takes 0.3 s (formats/notes/0002).
LightImage read_light_image(const std::string& path) {
    if (!std::filesystem::exists(path)) throw IoError({.file = path, .problem = "no such file"});
    void* module =
        dlopen("slim-light-image.so", RTLD_NOW | RTLD_LOCAL);  // counted; it stays to the end
    void* function = module ? dlsym(module, "slim_read_light_image") : nullptr;
    if (!function)
        throw IoError(path + ": cannot be read: " + dlerror() +
                          " (slim-light-image.so belongs beside the programs)",
                      ExitCode::internal);
    LightImage image;
    reinterpret_cast<void (*)(const std::string&, LightImage&)>(function)(path, image);
    return image;
}

}  // namespace slim
