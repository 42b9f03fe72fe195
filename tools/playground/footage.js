// A webcam or a video of the user's, taken down as frames of the robot's size. Nothing of it leaves the page.

/**
 * @typedef {import("#network").Clip} Clip
 * @typedef {{stop: () => void, done: Promise<void>}} Taking
 */

export const LONGEST = 300;

/**
 * Open a camera, or a file, as a video that plays.
 * @param {File | null} file null: the camera.
 * @returns {Promise<HTMLVideoElement>}
 */
export async function opened(file) {
  const video = document.createElement("video");
  video.muted = video.playsInline = true;
  if (file) video.src = URL.createObjectURL(file);
  else video.srcObject = await navigator.mediaDevices.getUserMedia({ video: { frameRate: { ideal: 30, max: 30 } } });
  await video.play();
  return video;
}

/**
 * Take frames down, one for each that the video shows, until it ends or there are enough.
 * @param {HTMLVideoElement} video
 * @param {Clip} clip That grows.
 * @param {() => void} grown Called after each frame.
 * @returns {Taking}
 */
export function taken(video, clip, grown) {
  const canvas = new OffscreenCanvas(clip.columns, clip.rows);
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (
    canvas.getContext("2d", { willReadFrequently: true })
  );
  let stop = () => {};
  const done = new Promise((/** @type {(value: void) => void} */ resolve) => {
    stop = () => {
      video.pause();
      const stream = video.srcObject;
      if (stream instanceof MediaStream) for (const track of stream.getTracks()) track.stop();
      URL.revokeObjectURL(video.src);
      resolve();
    };
    const take = () => {
      if (video.paused) return;
      context.drawImage(video, 0, 0, clip.columns, clip.rows);
      clip.frames.push(grey(context.getImageData(0, 0, clip.columns, clip.rows).data));
      grown();
      if (clip.frames.length >= LONGEST) stop();
      else video.requestVideoFrameCallback(take);
    };
    video.onended = () => stop();
    video.requestVideoFrameCallback(take);
  });
  return { stop: () => stop(), done };
}

/**
 * Compute the luma of colours, the Y of YUV (ITU-R BT.601).
 * @param {Uint8ClampedArray} rgba
 */
function grey(rgba) {
  const luma = new Uint8Array(rgba.length / 4);
  for (let i = 0; i < luma.length; i++)
    luma[i] = Math.round(0.299 * rgba[4 * i] + 0.587 * rgba[4 * i + 1] + 0.114 * rgba[4 * i + 2]);
  return luma;
}
