/* Bytes, halves, tables, local arrays, 64 bits and math.h, as terse as C allows. */
#include <stdint.h>
#include <string.h>
#include <math.h>
#include <stdbool.h>
int64_t sum64(const int32_t*x,int64_t n,int64_t start){int64_t s=start;for(int64_t i=0;i<n;i++)s+=x[i];return s;}
int64_t div64(int64_t a,int64_t b){return b?a/b:0;}
uint64_t udiv64(uint64_t a,uint64_t b){return b?a%b:a;}
int64_t muladd(int64_t a,int32_t b){return a*b+(a>>3);}
int tab2(int i,int j){static const int8_t t[4][4]={{-1,2,-3,4},{5,6,-7,8},{0,0,1,0},{9,-9,127,-128}};return t[i&3][j&3];}
int tab16(int i){static const int16_t t[5]={-32768,2,-3,32767,7};return t[i%5u];}
int64_t tab64(int i){static const int64_t t[4]={-5,6,7,-2147483648LL};return t[i&3];}
float tabf(int i){static const float t[4]={1.5f,-2.f,0.f,3.25f};return t[i&3];}
int init8(int i){uint8_t t[16]={1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16};t[i&15]=77;int s=0;for(int k=0;k<16;k++)s=s*3+t[k];return s;}
int loc2(int n){int a[8][8];for(int i=0;i<8;i++)for(int j=0;j<8;j++)a[i][j]=i*j+n;int s=0;for(int i=0;i<8;i++)s^=a[i][(i*n)&7];return s;}
struct P{uint8_t k;int16_t h;int32_t w;};
int locs(int n){struct P p[10];for(int i=0;i<10;i++){p[i].k=i*n;p[i].h=-i*n;p[i].w=i^n;}int s=0;for(int i=0;i<10;i++){struct P q=p[(i*n)&7];s+=q.k*q.h+q.w;}return s;}
float maths(float x,float y){return tanf(x)+hypotf(x,y)+log1pf(x*x)+expm1f(x)+fmodf(x,y)+asinf(x/(1+x*x))+roundf(x)+atan2f(x,y);}
float rnd(float x){return roundf(x);}
int8_t ret8(int x){return (int8_t)x;}
uint16_t ret16(int8_t a,uint16_t b){return a*b;}
bool odd(uint8_t a){return a&1;}
void cp(uint8_t*restrict d,const uint8_t*restrict s,int n){memcpy(d,s,n);}
void mv(uint8_t*d,int n){memmove(d+1,d,n);}
int popc(uint64_t x){return __builtin_popcountll(x)+__builtin_clz((uint32_t)x|1);}
int cmps(const char*a,const char*b){while(*a&&*a==*b){a++;b++;}return (unsigned char)*a-(unsigned char)*b;}
void base64(const uint8_t*in,uint8_t*out,int n){static const char t[]="ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
for(int i=0;i+2<n;i+=3){uint32_t v=in[i]<<16|in[i+1]<<8|in[i+2];for(int k=0;k<4;k++)*out++=t[v>>(18-6*k)&63];}}
uint64_t mum(uint32_t a,uint32_t b){return (uint64_t)a*b;}
uint32_t load4(const uint8_t*p,int i){uint32_t v;memcpy(&v,p+4*i,4);return v;}
int rd(const uint8_t *p,int n){uint8_t w[4];int s=0;for(int i=0;i<n;i++){w[i&3]=p[i];s+=w[(i+1)&3]*(i>3);}return s;}
int pun(float x){union{float f;uint32_t u;uint8_t b[4];}v[2];v[0].f=x;v[1].u=v[0].u^0x80000000u;return v[(int)x&1].b[3]+v[1].b[(int)x&3];}
static int count;
int keeps(int n){return count+=n;}
int sized(int n){int a[n+1];for(int i=0;i<=n;i++)a[i]=i*i;int s=0;for(int i=0;i<=n;i++)s+=a[(i*7)%(n+1)];return s;}
void longs(int64_t*x,int n){for(int i=0;i<n;i++)x[i]++;}
