#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CRawlog.h>

#include <holdfast/adapters/mrpt/mrpt.hpp>
#include <holdfast/adapters/mrpt/rawlog.hpp>
#include <holdfast/factors/whitening.hpp>

namespace holdfast {
namespace {

using namespace mrpt::obs;
using mrpt::poses::CPose3D;

constexpr Agent kPose('x'), kBeacon('b'), kLandmark('l');

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {
    dataset_.name = path;
    dataset_.format = Format::Toro;  // one agent, vertices are a guess
  }

  Dataset read() {
    CRawlog log;
    if (!log.loadFromRawLogFile(path_)) fail<BadFile>("cannot read ", path_, ": MRPT finds no rawlog in it");
    if (log.size() == 0) fail<BadFile>("cannot read ", path_, ": it holds no action and no observation");
    in_space_ = has_action<CActionRobotMovement3D>(log);
    if (in_space_ && has_action<CActionRobotMovement2D>(log))
      fail<BadFile>(path_, ": it has actions in the plane and in space; keep one kind");
    for (entry_ = 0; entry_ < log.size(); ++entry_) {
      switch (log.getType(entry_)) {
        case CRawlog::TEntryType::etActionCollection:
          for (const auto& action : *log.getAsAction(entry_)) take(*action);
          break;
        case CRawlog::TEntryType::etSensoryFrame:
          for (const auto& observation : *log.getAsObservations(entry_)) take(*observation);
          break;
        case CRawlog::TEntryType::etObservation:
          take(*log.getAsObservation(entry_));
          break;
        default:
          unknown("a comment or annotation");
      }
    }
    if (dataset_.edges.empty())
      fail<BadFile>(path_, ": it holds neither odometry nor ranges that could be used; ", unknown_report(dataset_));
    return std::move(dataset_);
  }

 private:
  template <class Action>
  static bool has_action(const CRawlog& log) {
    for (std::size_t i = 0; i < log.size(); ++i)
      if (log.getType(i) == CRawlog::TEntryType::etActionCollection)
        for (const auto& action : *log.getAsAction(i))
          if (dynamic_cast<const Action*>(action.get()) != nullptr) return true;
    return false;
  }

  void take(const CAction& action) {
    if (const auto* plane = dynamic_cast<const CActionRobotMovement2D*>(&action)) {
      mrpt::poses::CPosePDFGaussian change;
      change.copyFrom(*plane->poseChange.get_ptr());
      step(change);
    } else if (const auto* space = dynamic_cast<const CActionRobotMovement3D*>(&action)) {
      mrpt::poses::CPose3DPDFGaussian change;
      change.copyFrom(space->poseChange);
      step(change);
    } else {
      unknown(action.GetRuntimeClass()->className);
    }
  }
  template <class Pdf>
  void step(const Pdf& change) {
    using V = typename MrptConstraint<Pdf>::Pose;
    const V measured = MrptConstraint<Pdf>::measured(change);
    const MatrixNoise<V::dim> of_deviation{detail::inverse_of(MrptConstraint<Pdf>::information(change), "information of an action"),
                                           Format::PyFG};
    add(RelativePoseEdge<V>{kPose(pose_), kPose(pose_ + 1), measured, {}, of_deviation.converted(Format::Toro, measured)}, {});
    ++pose_;
  }

  void take(const CObservation& observation) {
    const double time = mrpt::Clock::toDouble(observation.timestamp);
    if (const auto* ranges = dynamic_cast<const CObservationBeaconRanges*>(&observation))
      take(*ranges, time);
    else if (const auto* bearings = dynamic_cast<const CObservationBearingRange*>(&observation))
      take(*bearings, time);
    else
      unknown(observation.GetRuntimeClass()->className);
  }

  void take(const CObservationBeaconRanges& observation, double time) {
    for (const auto& one : observation.sensedData) {
      if (one.beaconID == INVALID_BEACON_ID) {
        unknown("CObservationBeaconRanges without an id");
        continue;
      }
      if (!(one.sensedDistance > observation.minSensorDistance && one.sensedDistance <= observation.maxSensorDistance)) {
        unknown("CObservationBeaconRanges out of the sensor's limits");
        continue;
      }
      if (one.sensorLocationOnRobot.norm() > kZeroDistance)
        fail<BadFile>(path_, ", entry ", entry_, ": the receiver of beacon ", one.beaconID, " is ", one.sensorLocationOnRobot.norm(),
                      " m off the robot's origin, and Range measures from the origin; give a factor of your own with the lever arm");
      add(RangeEdge{kPose(pose_), kBeacon(one.beaconID), one.sensedDistance, double(observation.stdError) * observation.stdError}, time);
    }
  }

  void take(const CObservationBearingRange& observation, double time) {
    const Pose3 T_body_sensor = StandsFor<CPose3D>::ours(observation.sensorLocationOnRobot);
    for (const auto& one : observation.sensedData) {
      if (one.landmarkID < 0) {
        unknown("CObservationBearingRange without an id");
        continue;
      }
      Matrix<3, 3> polar = Matrix<3, 3>::Zero();
      if (observation.validCovariances)
        polar = one.covariance.asEigen();
      else
        polar.diagonal() << observation.sensor_std_range, observation.sensor_std_yaw, observation.sensor_std_pitch;
      if (!observation.validCovariances) polar = polar * polar;
      landmark(kLandmark(one.landmarkID), T_body_sensor, one.range, one.yaw, one.pitch, polar, time);
    }
  }
  void landmark(Key key, const Pose3& T_body_sensor, double range, double yaw, double pitch, const Matrix<3, 3>& polar, double time) {
    const double cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
    const Vector<3> direction(cp * cy, cp * sy, -sp);  // MRPT's pitch points down
    Matrix<3, 3> J;
    J << direction, range * Vector<3>(-cp * sy, cp * cy, 0), range * Vector<3>(-sp * cy, -sp * sy, -cp);
    J = T_body_sensor.rotation() * J;
    const Vector<3> p = T_body_sensor.p + T_body_sensor.to_world(range * direction);
    if (in_space_) {
      add_landmark<Point3>(key, p, J * polar * J.transpose(), time);
    } else {
      const Matrix<2, 2> cov = J.topLeftCorner<2, 2>() * polar.topLeftCorner<2, 2>() * J.topLeftCorner<2, 2>().transpose();
      add_landmark<Point2>(key, p.head<2>(), cov, time);
    }
  }
  template <class Point>
  void add_landmark(Key key, const Vector<Point::dim>& p, const Matrix<Point::dim, Point::dim>& covariance, double time) {
    const Matrix<Point::dim, Point::dim> symmetric = 0.5 * (covariance + covariance.transpose());
    sqrt_information_from_covariance<Point::dim>(symmetric, "CObservationBearingRange: the covariance of a landmark");
    add(RelativePointEdge<Point>{kPose(pose_), key, Point(p), {}, {symmetric, Format::PyFG}, {}}, time);
  }

  template <class M>
  void add(M&& measurement, std::optional<double> time) {
    dataset_.edges.push_back({std::forward<M>(measurement), time, entry_ + 1});
  }
  void unknown(const std::string& what) { dataset_.unknown.push_back({what, what, entry_ + 1}); }

  const std::string path_;
  Dataset dataset_;
  bool in_space_ = false;
  std::uint64_t pose_ = 0;
  std::size_t entry_ = 0;
};

}  // namespace

Dataset read_rawlog(const std::string& path) {
  try {
    return Reader(path).read();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail<BadFile>("cannot read ", path, ": ", error.what());
  }
}

}  // namespace holdfast
