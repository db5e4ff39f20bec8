// What the pages of machines in space use of three.js; README.md says how three.js follows from it.

export {
  AmbientLight, BoxGeometry, BufferAttribute, BufferGeometry, CatmullRomCurve3, Color, CylinderGeometry, DirectionalLight, Group,
  Mesh, MeshLambertMaterial, OrthographicCamera, Raycaster, Scene, SphereGeometry, TubeGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
export { toCreasedNormals } from "three/addons/utils/BufferGeometryUtils.js";
