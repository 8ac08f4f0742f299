#include "pipeline/folder_lock.h"

#include "slim/base/error.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace slim {
namespace {

/// Whether the path still leads to what was opened: its owner may have removed it in between.
bool still_there(const std::string& folder, int descriptor) {
    struct stat opened {
    }, named{};
    return fstat(descriptor, &opened) == 0 && stat(folder.c_str(), &named) == 0 &&
           opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

int open_folder(const std::string& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const int descriptor = error ? -1 : open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0)
        throw IoError(fmt::format("{}: cannot be created: {}", folder,
                                  error ? error.message() : std::strerror(errno)),
                      ExitCode::usage);
    return descriptor;
}

}  // namespace

FolderLock::FolderLock(const std::string& folder) {
    for (;;) {
        descriptor_ = open_folder(folder);
        if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            close(descriptor_);
            throw Error(ExitCode::temporary,
                        folder +
                            ": another slim is at work in it: wait for its end, or name another "
                            "output or --work folder");
        }
        if (still_there(folder, descriptor_)) return;
        close(descriptor_);
    }
}

FolderLock::~FolderLock() { close(descriptor_); }

}  // namespace slim
