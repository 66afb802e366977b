#include <holdfast/common/log.hpp>
#ifdef HOLDFAST_WITH_GLOG
#include <glog/logging.h>
#endif

namespace holdfast::common {

#ifdef HOLDFAST_WITH_GLOG
void start_log(bool verbose) {
  // No failure signal handler and no FATAL: an error of the user is a message and an exit code, never a core dump.
  FLAGS_logtostderr = true;
  // What Ceres warns of ends up in the reason why it stopped: nobody needs it twice.
  FLAGS_minloglevel = verbose ? google::GLOG_INFO : google::GLOG_FATAL;
  if (!google::IsGoogleLoggingInitialized()) google::InitGoogleLogging("holdfast");
}
void log(const std::string& message) {
  if (google::IsGoogleLoggingInitialized()) LOG(INFO) << message;  // else a test, or somebody else's program: glog would scold
}
#else
void start_log(bool) {}
void log(const std::string&) {}
#endif

}  // namespace holdfast::common
