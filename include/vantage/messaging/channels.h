#pragma once

/// @file
/// Names of the channels, without the prefix that a link puts before them. See docs/lcm.md.

namespace vantage {

inline constexpr char kJointStateChannel[] = "JOINT_STATE";                 ///< JointState.
inline constexpr char kJointCommandChannel[] = "JOINT_COMMAND";             ///< JointCommand.
inline constexpr char kCameraPoseChannel[] = "CAMERA_POSE";                 ///< CameraPose.
inline constexpr char kCameraPoseCommandChannel[] = "CAMERA_POSE_COMMAND";  ///< CameraPose.
inline constexpr char kCameraImageChannel[] = "CAMERA_IMAGE";               ///< CameraImage.
inline constexpr char kImageFeaturesChannel[] = "IMAGE_FEATURES";           ///< ImageFeatures.
inline constexpr char kObservabilityChannel[] = "OBSERVABILITY";  ///< ObservabilityReport.
inline constexpr char kServoStatusChannel[] = "SERVO_STATUS";     ///< ServoStatus.
inline constexpr char kServoInputsChannel[] = "SERVO_INPUTS";     ///< ServoRecord.
inline constexpr char kServoSetupChannel[] = "SERVO_SETUP";       ///< ServoSetup.
inline constexpr char kSimTruthChannel[] = "SIM_TRUTH";           ///< GroundTruth.

}  // namespace vantage
