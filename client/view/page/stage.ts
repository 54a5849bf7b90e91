// SPDX-License-Identifier: MIT
// The picture: renderer, camera, light. Metres, z up, as scenes are. It is drawn when something has changed.
import {
  AmbientLight, Color, DirectionalLight, OrbitControls, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "./vendor/libraries.js";

// Which takes most of its time for smooth edges.
function inSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(35, 1, 1e-4, 100);
  readonly renderer = new WebGLRenderer({ antialias: !inSoftware() });
  readonly controls: OrbitControls;
  size = 0.2; // m, of what there is to see
  frames = 0;
  private changed = true;
  private light = new DirectionalLight(0xffffff, 2.2);

  constructor(private host: HTMLElement, private before: () => void) {
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    host.append(this.renderer.domElement);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    this.scene.add(new AmbientLight(0xffffff, 1.3), this.light, this.light.target);
    new ResizeObserver(() => this.resize()).observe(host);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const paper = () => {
      this.scene.background = new Color(dark.matches ? 0x14171b : 0xf6f5f2);
      this.draw();
    };
    dark.addEventListener("change", paper);
    paper();
    this.resize();
    const turn = () => {
      requestAnimationFrame(turn);
      if (!this.changed) return;
      this.changed = false;
      this.before();
      this.light.position.copy(this.camera.position).add(new Vector3(0, 0, this.size));
      this.light.target.position.copy(this.controls.target);
      this.renderer.render(this.scene, this.camera);
      ++this.frames;
    };
    requestAnimationFrame(turn);
  }

  draw(): void {
    this.changed = true;
  }

  // Looks at a box from its front, a little from above.
  frame(low: Vector3, high: Vector3): void {
    const middle = low.clone().add(high).multiplyScalar(0.5);
    this.size = Math.max(high.distanceTo(low), 0.02);
    const distance = (0.62 * this.size) / Math.tan((this.camera.fov * Math.PI) / 360) / Math.min(1, this.camera.aspect);
    this.camera.near = this.size / 200;
    this.camera.far = this.size * 40;
    this.camera.position.copy(middle).add(new Vector3(0.35, -0.88, 0.32).normalize().multiplyScalar(distance));
    this.controls.target.copy(middle);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  // Of a point in the world, in CSS pixels of the stage.
  pixel(point: Vector3): { x: number; y: number } {
    const p = point.clone().project(this.camera);
    return { x: ((p.x + 1) / 2) * this.host.clientWidth, y: ((1 - p.y) / 2) * this.host.clientHeight };
  }

  private resize(): void {
    const width = Math.max(this.host.clientWidth, 1), height = Math.max(this.host.clientHeight, 1);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
}
