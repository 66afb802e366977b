// Files that are whole or not there: no reader, and no crash, ever sees half a file.
#pragma once

#include <string>
#include <string_view>

namespace holdfast {

/// Writes `content` to a new file beside `path`, flushes it to the disk and renames it to `path`.
/// BadFile naming the path and the system's reason where any step fails; then `path` is as it was and no temporary file stays.
/// A path that exists and is no regular file (a directory, a device, a pipe) is refused: a rename would replace it. A symbolic link stays,
/// and what it points to is written.
void atomic_write(const std::string& path, std::string_view content);

}  // namespace holdfast
